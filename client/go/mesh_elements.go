package collided

import (
	"context"
	"encoding/binary"
	"time"

	"google.golang.org/grpc/codes"

	v1 "collided.invalid/client/go/v1"
)

const (
	readTries    = 8
	elementBytes = 12
)

// MeshElements is what a mesh of a living scene is made of.
type MeshElements struct {
	// Elements are in the order of their scene-wide ids: triangles, then loose edges as a b b, then loose points as a a a.
	// Vertices are numbered within the mesh.
	Elements [][3]uint32
	// VertexCount is 0 if the mesh was removed.
	VertexCount uint32
	// EditCount is the scene's when this was so.
	EditCount uint64
}

// GetMesh tells what a mesh of a scene is made of now, whoever created it. mesh is its index in the scene's spec. Aborted if
// edits keep changing it.
func (c *Client) GetMesh(ctx context.Context, sceneID string, mesh uint32) (*MeshElements, error) {
	request := &v1.GetMeshRequest{SceneId: sceneID, Mesh: mesh}
	out, begun := &MeshElements{}, time.Now()
	for tries := readTries; ; {
		request.FirstElement = uint32(len(out.Elements))
		more := time.Duration(len(out.Elements)*elementBytes/chunkBytes) * time.Second // as uploads have
		page, err := c.meshPage(ctx, sceneID, request, begun.Add(c.connector.options.Deadline+more))
		hasFewer := err != nil && len(out.Elements) > 0 && err.(*Error).Field == "first_element"
		if err != nil && !hasFewer {
			return nil, err
		}
		if hasFewer || len(out.Elements) > 0 && page.EditCount != out.EditCount { // edited between two pages
			if tries--; tries == 0 {
				return nil, failf(codes.Aborted, "", "the scene was edited while mesh %d was read, %d times", mesh, readTries)
			}
			out = &MeshElements{}
			continue
		}
		if err := out.add(page); err != nil {
			return nil, err
		}
		if len(out.Elements) == int(page.ElementCount) {
			return out, nil
		}
	}
}

// meshPage asks for one of several pages, all of which together are due.
func (c *Client) meshPage(ctx context.Context, sceneID string, request *v1.GetMeshRequest,
	due time.Time) (*v1.GetMeshResponse, error) {
	limited, cancel := context.WithDeadline(ctx, due)
	defer cancel()
	return call(limited, c, sceneID, c.service.GetMesh, request)
}

// add appends a page. DataLoss if it does not fit the mesh.
func (m *MeshElements) add(page *v1.GetMeshResponse) error {
	bytes, before, total := page.Elements, len(m.Elements), int(page.ElementCount)
	count := len(bytes) / elementBytes
	if len(bytes)%elementBytes != 0 || before+count > total || count == 0 && before < total {
		return failf(codes.DataLoss, "", "elements has %d bytes after %d of %d elements", len(bytes), before, total)
	}
	for ; len(bytes) > 0; bytes = bytes[elementBytes:] {
		var element [3]uint32
		for k := range element {
			element[k] = binary.LittleEndian.Uint32(bytes[4*k:])
			if element[k] >= page.VertexCount {
				return failf(codes.DataLoss, "", "elements name vertex %d of %d", element[k], page.VertexCount)
			}
		}
		m.Elements = append(m.Elements, element)
	}
	m.VertexCount, m.EditCount = page.VertexCount, page.EditCount
	return nil
}
