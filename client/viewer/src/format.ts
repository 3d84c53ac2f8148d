// Numbers as people read them.

const counts = new Intl.NumberFormat("en");
const digits = new Intl.NumberFormat("en", { maximumSignificantDigits: 3 });

export const count = (value: number): string => counts.format(value);

export function milliseconds(value: number): string {
  if (value >= 1000) return `${digits.format(value / 1000)} s`;
  if (value >= 1 || value === 0) return `${digits.format(value)} ms`;
  return `${digits.format(value * 1000)} µs`;
}

export function bytes(value: number): string {
  const units = ["B", "KB", "MB", "GB", "TB"];
  let unit = 0;
  for (; value >= 1000 && unit < units.length - 1; ++unit) value /= 1000;
  return `${digits.format(value)} ${units[unit]}`;
}

/** Short, for axes: 12.5k. */
export const axis = new Intl.NumberFormat("en", { notation: "compact", maximumSignificantDigits: 3 }).format;

export const plain = digits.format;

/** "narrow_vt" to "narrow vt". */
export const words = (name: string): string => name.replaceAll("_", " ");
