package collided

import v1 "collided/client/go/v1"

// Output is the daemon's whole answer to one frame. One that was refused or skipped has no contacts.
type Output struct {
	ContactSet
	FrameID uint64
	// Done has totals and metrics; nil if the frame was refused or skipped.
	Done *v1.FrameDone
	// Err is why the frame was refused; the scene is as it was, and a stream goes on.
	Err error
	// Skipped: a later frame replaced it (LATEST_WINS).
	Skipped bool
}

// finish takes the last contacts and the totals.
func (o *Output) finish(done *v1.FrameDone) error {
	if err := checkDone(done); err != nil {
		return err
	}
	if err := o.addAll(done.Contacts); err != nil {
		return err
	}
	done.Contacts = nil
	o.Done = done
	return nil
}
