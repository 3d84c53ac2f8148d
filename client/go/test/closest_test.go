package test

import (
	"reflect"
	"testing"

	collided "collided.invalid/client/go"
)

func TestAByteOfFeaturesSaysWhereTheClosestPointsAre(t *testing.T) {
	for features, place := range map[byte]collided.TrianglePlace{
		0: collided.OnFace, 32 + 1: collided.OnSide1, 2: collided.OnSide2, 64 + 3: collided.OnSide3,
		4: collided.OnCorner1, 5: collided.OnCorner2, 16 + 6: collided.OnCorner3,
	} {
		same(t, collided.PlaceOnTriangle(features), place)
	}
	for features, places := range map[byte][2]collided.EdgePlace{
		16: {collided.Inside, collided.Inside}, 64 + 1 + 8: {collided.OnEnd1, collided.OnEnd2}, 2 + 4: {collided.OnEnd2, collided.OnEnd1},
	} {
		p, q := collided.PlacesOnEdges(features)
		same(t, [2]collided.EdgePlace{p, q}, places)
	}
	same(t, [3]byte{collided.NearerAtFirst, collided.NearerAtSecond, collided.SameAsBefore}, [3]byte{16, 32, 64})
}

func TestKeptContactsAreThoseThatNoOtherCovers(t *testing.T) {
	contacts := collided.Contacts{Count: 3, Flags: []byte{collided.IsCertified, collided.IsCertified | collided.IsCovered, 0}}
	if kept := contacts.Kept(); !reflect.DeepEqual(kept, []int{0, 2}) {
		t.Fatal(kept)
	}
	contacts.Flags = nil
	same(t, len(contacts.Kept()), 3)
}
