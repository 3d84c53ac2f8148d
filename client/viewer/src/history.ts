// The last frames, within a budget of memory; what the time line goes through.
import type { FrameMessage } from "./messages";

const MAX_FRAMES = 600;
const MAX_BYTES = 128 << 20;

export class History {
  private frames: FrameMessage[] = [];
  private bytes = 0;

  get length(): number {
    return this.frames.length;
  }

  at(index: number): FrameMessage | undefined {
    return this.frames[index];
  }

  add(frame: FrameMessage): void {
    this.frames.push(frame);
    this.bytes += frame.bytes;
    while (this.frames.length > MAX_FRAMES || (this.bytes > MAX_BYTES && this.frames.length > 1))
      this.bytes -= this.frames.shift()!.bytes;
  }

  clear(): void {
    this.frames = [];
    this.bytes = 0;
  }
}
