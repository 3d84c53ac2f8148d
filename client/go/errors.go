package collided

import (
	"context"
	"errors"
	"fmt"
	"strings"
	"time"

	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"
	"google.golang.org/protobuf/proto"

	"collided.invalid/client/go/internal/features"
	v1 "collided.invalid/client/go/v1"
)

// Error is what every function of this package fails with. Is tells context.Canceled and context.DeadlineExceeded.
type Error struct {
	// Code is gRPC's, such as codes.InvalidArgument.
	Code codes.Code
	// Message names the field, its value and the limit.
	Message string
	// Field is the path of the refused field as the protocol names it, such as "frame.updates[0].positions".
	Field string
	// Quota is the limit that was reached, its value and what was requested.
	Quota string
	// RetryAfter is when the same request may succeed; 0: waiting would not help.
	RetryAfter time.Duration
}

func (e *Error) Error() string { return fmt.Sprintf("%v: %s", e.Code, e.Message) }

// Is makes errors.Is(err, context.Canceled) tell whether a call was cancelled.
func (e *Error) Is(target error) bool {
	return target == context.Canceled && e.Code == codes.Canceled ||
		target == context.DeadlineExceeded && e.Code == codes.DeadlineExceeded
}

// IsConnectionLost tells whether the connection or the daemon was lost, rather than a request refused: reconnect and
// resume the scene.
func IsConnectionLost(err error) bool {
	var e *Error
	return errors.As(err, &e) && (e.Code == codes.Unavailable || e.Code == codes.Canceled || e.Code == codes.Internal)
}

func failf(code codes.Code, field, format string, arguments ...any) *Error {
	return &Error{Code: code, Field: field, Message: fmt.Sprintf(format, arguments...)}
}

// invalidf is of a value that is refused before it is sent; its message begins with the field.
func invalidf(field, format string, arguments ...any) *Error {
	return failf(codes.InvalidArgument, field, "%s "+format, append([]any{field}, arguments...)...)
}

func errorOfLack(lack *features.Lack) *Error {
	return failf(codes.Unimplemented, lack.What, "%s", lack.Message)
}

func contextError(err error) error {
	if err == nil {
		return nil
	}
	return errorOf(status.FromContextError(err).Err())
}

// errorOf is the error of a call; nil if it ended well.
func errorOf(err error) error {
	if err == nil {
		return nil
	}
	var known *Error
	if errors.As(err, &known) {
		return known
	}
	s := status.Convert(err)
	e := &Error{Code: s.Code(), Message: s.Message()}
	// gRPC refuses what is far above the daemon's limit by itself, and does not know which option sets it.
	if strings.HasPrefix(e.Message, "Received message larger than max") {
		e.Message += " (the daemon's option max-message-mb)"
	}
	for _, detail := range s.Proto().GetDetails() {
		e.read(detail.GetTypeUrl(), detail.GetValue())
	}
	return e
}

// read ignores what it cannot read: a proxy may have answered.
func (e *Error) read(typeURL string, value []byte) {
	var bad v1.BadRequest
	var quota v1.QuotaFailure
	var retry v1.RetryInfo
	unpack := func(name string, into proto.Message) bool {
		return strings.HasSuffix(typeURL, "/google.rpc."+name) && proto.Unmarshal(value, into) == nil
	}
	if unpack("BadRequest", &bad) && len(bad.FieldViolations) > 0 {
		e.Field = bad.FieldViolations[0].Field
	}
	if unpack("QuotaFailure", &quota) && len(quota.Violations) > 0 {
		e.Quota = quota.Violations[0].Subject + ": " + quota.Violations[0].Description
	}
	if unpack("RetryInfo", &retry) {
		e.RetryAfter = time.Duration(retry.GetRetryDelay().GetSeconds())*time.Second + time.Duration(retry.GetRetryDelay().GetNanos())
	}
}

func errorOfFrame(refused *v1.FrameError) *Error {
	return &Error{
		Code:       codes.Code(refused.Code),
		Message:    refused.Message,
		Field:      refused.Field,
		RetryAfter: time.Duration(refused.RetryAfterSeconds * float64(time.Second)),
	}
}
