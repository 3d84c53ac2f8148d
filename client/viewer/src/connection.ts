// The WebSocket to collidectl, opened again whenever it is lost.
import { decode, type Message } from "./messages";

const FIRST_PAUSE_MS = 500;
const LONGEST_PAUSE_MS = 4000;

export class Connection {
  private pause = FIRST_PAUSE_MS;

  constructor(
    private readonly take: (message: Message) => void,
    private readonly lost: () => void,
  ) {
    this.open();
  }

  private open(): void {
    const url = new URL("frames", location.href);
    url.protocol = url.protocol.replace("http", "ws");
    const socket = new WebSocket(url);
    socket.binaryType = "arraybuffer";
    socket.onmessage = (event) => {
      this.pause = FIRST_PAUSE_MS;
      const message = decode(event.data);
      this.take(message);
      // The next frame comes once the browser had time to show this one; a hidden tab asks more slowly.
      if (message.kind === "frame") afterNextPaint(() => socket.readyState === WebSocket.OPEN && socket.send("next"));
    };
    socket.onclose = () => {
      this.lost();
      setTimeout(() => this.open(), this.pause);
      this.pause = Math.min(2 * this.pause, LONGEST_PAUSE_MS);
    };
  }
}

function afterNextPaint(then: () => void): void {
  if (document.hidden) setTimeout(then, 1000);
  else requestAnimationFrame(() => setTimeout(then));
}
