// The package's only error: a gRPC code, a message and the details that came with them.

import { type Metadata, status as Code } from "@grpc/grpc-js";
import type { FrameError } from "./generated/collided/v1/frame.js";
import { BadRequest, QuotaFailure, RetryInfo, RpcStatus } from "./generated/collided/v1/error_details.js";

/** Codes of gRPC, such as `Code.INVALID_ARGUMENT`. */
export { Code };

/** What a refusal says besides its message. */
export interface ErrorDetails {
  /** Path of the refused field as the protocol names it, such as "frame.updates[0].positions"; empty: none was named. */
  field?: string;
  /** The limit that was reached, its value and what was requested; empty: none was. */
  quota?: string;
  /** Seconds after which the same request may succeed; undefined: waiting would not help. */
  retryAfterSeconds?: number | undefined;
}

/** Everything that this package throws or rejects with. `message` names the field, its value and the limit. */
export class CollidedError extends Error {
  readonly field: string;
  readonly quota: string;
  readonly retryAfterSeconds: number | undefined;

  constructor(
    /** A code of gRPC. */
    readonly code: Code,
    message: string,
    details: ErrorDetails = {},
  ) {
    super(message);
    this.name = `CollidedError [${Code[code] ?? code}]`;
    this.field = details.field ?? "";
    this.quota = details.quota ?? "";
    this.retryAfterSeconds = details.retryAfterSeconds;
  }

  /** Whether the connection or the daemon was lost, rather than a request refused: reconnect and resume the scene. */
  get isConnectionLost(): boolean {
    return [Code.UNAVAILABLE, Code.CANCELLED, Code.INTERNAL].includes(this.code);
  }
}

/** The error of a value that is refused before it is sent. */
export function invalid(field: string, what: string): CollidedError {
  return new CollidedError(Code.INVALID_ARGUMENT, `${field} ${what}`, { field });
}

/** The error of a call that ended with another status than OK. */
export function errorOfStatus(status: { code: Code; details: string; metadata?: Metadata }): CollidedError {
  return new CollidedError(status.code, namingOption(status.details), detailsOf(status.metadata));
}

/** gRPC refuses what is far above the daemon's limit by itself, and does not know which option sets it. */
function namingOption(message: string): string {
  return message.startsWith("Received message larger than max") ? `${message} (the daemon's option max-message-mb)` : message;
}

/** The error of a frame that was refused within a stream. */
export function errorOfFrame(error: FrameError): CollidedError {
  const { field, retryAfterSeconds: wait } = error;
  return new CollidedError(error.code, error.message, { field, retryAfterSeconds: wait > 0 ? wait : undefined });
}

function detailsOf(metadata: Metadata | undefined): ErrorDetails {
  const out: ErrorDetails = {};
  for (const bytes of metadata?.get("grpc-status-details-bin") ?? []) {
    if (typeof bytes !== "string") addDetails(out, bytes);
  }
  return out;
}

/** Bytes that cannot be read have no details: a proxy may have answered. */
function addDetails(out: ErrorDetails, bytes: Uint8Array): void {
  try {
    for (const { typeUrl, value } of RpcStatus.decode(bytes).details) {
      readers[typeUrl.slice(typeUrl.lastIndexOf("/") + 1)]?.(out, value);
    }
  } catch {
    return;
  }
}

const readers: Record<string, (out: ErrorDetails, value: Uint8Array) => void> = {
  "google.rpc.BadRequest": (out, value) => {
    const violation = BadRequest.decode(value).fieldViolations[0];
    if (violation) out.field = violation.field;
  },
  "google.rpc.QuotaFailure": (out, value) => {
    const violation = QuotaFailure.decode(value).violations[0];
    if (violation) out.quota = `${violation.subject}: ${violation.description}`;
  },
  "google.rpc.RetryInfo": (out, value) => {
    const delay = RetryInfo.decode(value).retryDelay;
    if (delay) out.retryAfterSeconds = Number(delay.seconds) + delay.nanos * 1e-9;
  },
};
