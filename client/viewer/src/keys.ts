// Keys for all that the mouse can do.

/** `actions` by key, as KeyboardEvent.key names it, with "shift+" before keys that need it. */
export function bindKeys(actions: Record<string, () => void>): void {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.target as HTMLElement;
    // Space presses the button, or ticks the box, that has the focus.
    if (event.key === " " && target.matches("button, input[type=checkbox], summary")) return;
    const isArrow = event.key.startsWith("Arrow");
    const key = (event.shiftKey && isArrow ? "shift+" : "") + (event.key.length === 1 ? event.key.toLowerCase() : event.key);
    const action = actions[key === "=" ? "+" : key];
    if (!action) return;
    event.preventDefault();
    action();
  });
}
