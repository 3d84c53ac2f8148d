// Package collided is a client of the daemon collided, which finds the contacts of moving meshes. Connect connects, a Client
// creates scenes, and a Stream takes frames and gives their contacts. Every error is an *Error. The messages of the protocol,
// with the unit and range of each field, are in package v1.
package collided

//go:generate ./generate

import (
	"context"
	"crypto/rand"
	"encoding/hex"
	"time"

	"google.golang.org/grpc"
	"google.golang.org/grpc/codes"
	"google.golang.org/protobuf/proto"

	"collided.invalid/client/go/internal/features"
	v1 "collided.invalid/client/go/v1"
)

const (
	createTries   = 3
	chunkBytes    = (1 << 19) / 12 * 12 // whole triangles, well below the limit of any daemon
	uploadsAtOnce = 8
	maxInline     = 4 << 20 // bytes of triangles in the message that creates a scene
)

// Client is a connection to a daemon. Any goroutine may use it.
type Client struct {
	connector  *connector
	connection *grpc.ClientConn
	service    v1.CollisionServiceClient
	info       *v1.GetServerInfoResponse
	features   *features.Features // nil until info is known
	daemon     *Daemon            // its own; nil: none
}

// Connect connects to the daemon at address, host:port or unix:/path. If it is empty, it starts a daemon of its own, which
// Close stops: $COLLIDED_DAEMON, or collided on the PATH.
func Connect(ctx context.Context, address string, options Options) (*Client, error) {
	var daemon *Daemon
	if address == "" {
		var err error
		if daemon, err = StartDaemon(ctx); err != nil {
			return nil, err
		}
		address = daemon.Address
	}
	client, err := connect(ctx, address, options)
	if err != nil {
		daemon.Stop()
		return nil, err
	}
	client.daemon = daemon
	return client, nil
}

func connect(ctx context.Context, address string, options Options) (*Client, error) {
	connector, err := newConnector(address, options)
	if err != nil {
		return nil, err
	}
	return connector.client(ctx)
}

// client makes a new connection.
func (c *connector) client(ctx context.Context) (*Client, error) {
	connection, err := c.connect(ctx, "")
	if err != nil {
		return nil, err
	}
	client := &Client{connector: c, connection: connection, service: v1.NewCollisionServiceClient(connection)}
	if client.info, err = client.GetServerInfo(ctx); err != nil {
		connection.Close()
		return nil, err
	}
	client.features = features.Of(client.info, c.address)
	return client, nil
}

// Close closes the connection, and stops the daemon if it is the client's own. Streams and watches have their own connections.
func (c *Client) Close() {
	c.connection.Close()
	c.daemon.Stop()
}

// ServerInfo has version, devices and limits of the daemon when the client connected.
func (c *Client) ServerInfo() *v1.GetServerInfoResponse { return c.info }

// GetServerInfo asks for version, devices and limits of the daemon.
func (c *Client) GetServerInfo(ctx context.Context) (*v1.GetServerInfoResponse, error) {
	return call(ctx, c, "", c.service.GetServerInfo, &v1.GetServerInfoRequest{})
}

// CreateScene creates a scene of spec, which must have no meshes, and meshes, ready for frames. It retries if the answer is
// lost, without ever creating two scenes. The scene is deleted after lease without a stream or a call; 0: the daemon's default.
func (c *Client) CreateScene(ctx context.Context, spec *SceneSpec, meshes []Mesh, lease time.Duration) (*Scene, error) {
	input, err := newSceneInput(spec, meshes)
	if err != nil {
		return nil, err
	}
	return c.createScene(ctx, input, lease)
}

func (c *Client) createScene(ctx context.Context, input *sceneInput, lease time.Duration) (*Scene, error) {
	spec, uploads := input.withSmall(c.info.GetLimits().GetMaxMessageBytes())
	scene, err := c.create(ctx, &v1.CreateSceneRequest{RequestId: randomID(), Spec: spec, LeaseSeconds: lease.Seconds()})
	if err != nil {
		return nil, err
	}
	if len(uploads) == 0 {
		return scene, nil
	}
	whole, err := c.uploadAll(ctx, scene.SceneId, input, uploads)
	if err != nil {
		c.tryDelete(scene.SceneId)
		return nil, err
	}
	return whole, nil
}

// uploadAll uploads several meshes at a time, as each takes a round trip. It returns the scene once it has all meshes.
func (c *Client) uploadAll(ctx context.Context, id string, input *sceneInput, uploads []int) (*Scene, error) {
	ctx, cancel := context.WithCancel(ctx)
	defer cancel() // what is still on its way after an error
	type answer struct {
		mesh    int
		isAlone bool
		scene   *Scene
		err     error
	}
	answers := make(chan answer, len(uploads))
	left, flying, atOnce := append([]int(nil), uploads...), 0, uploadsAtOnce
	var ready *Scene
	for len(left) > 0 || flying > 0 {
		for ; len(left) > 0 && flying < atOnce; flying++ {
			mesh, isAlone := left[0], atOnce == 1
			left = left[1:]
			go func() {
				scene, err := c.upload(ctx, id, uint32(mesh), input.triangles[mesh])
				answers <- answer{mesh, isAlone, scene, err}
			}()
		}
		got := <-answers
		flying--
		if got.err != nil {
			// A client may have few calls open, or little memory: this one goes again, once the others have ended.
			if got.isAlone || got.err.(*Error).Code != codes.ResourceExhausted {
				return nil, got.err
			}
			atOnce = 1
			left = append(left, got.mesh)
		} else if got.scene.GetState() == v1.SceneState_SCENE_STATE_READY {
			ready = got.scene
		}
	}
	return ready, nil
}

// tryDelete cleans up after an upload whose error is the one to tell; its context may be over.
func (c *Client) tryDelete(sceneID string) {
	ctx, cancel := context.WithTimeout(context.Background(), time.Second)
	defer cancel()
	_ = c.DeleteScene(ctx, sceneID)
}

func (c *Client) create(ctx context.Context, request *v1.CreateSceneRequest) (*Scene, error) {
	for try := 1; ; try++ {
		answer, err := call(ctx, c, "", c.service.CreateScene, request)
		if err == nil {
			return answer.GetScene(), checkScene(answer.GetScene())
		}
		if err.(*Error).Code != codes.Unavailable || try == createTries {
			return nil, err
		}
		if err := sleep(ctx, time.Duration(try)*200*time.Millisecond); err != nil {
			return nil, err
		}
	}
}

func (c *Client) upload(ctx context.Context, sceneID string, mesh uint32, triangles []byte) (*Scene, error) {
	more := time.Duration(len(triangles)/chunkBytes+1) * time.Second
	ctx, cancel := c.connector.callContext(ctx, sceneID, more)
	defer cancel()
	upload, err := c.service.UploadMesh(ctx)
	if err != nil {
		return nil, errorOf(err)
	}
	for len(triangles) > 0 {
		chunk := triangles[:min(chunkBytes, len(triangles))]
		if upload.Send(&v1.UploadMeshRequest{SceneId: sceneID, Mesh: mesh, Triangles: chunk}) != nil {
			break // CloseAndRecv says why
		}
		triangles = triangles[len(chunk):]
	}
	answer, err := upload.CloseAndRecv()
	return answer.GetScene(), errorOf(err)
}

// EstimateScene tells what CreateScene of the same arguments would cost, before anything is made; no triangle is sent.
func (c *Client) EstimateScene(ctx context.Context, spec *SceneSpec, meshes []Mesh) (*v1.EstimateSceneResponse, error) {
	input, err := newSceneInput(spec, meshes)
	if err != nil {
		return nil, err
	}
	return call(ctx, c, "", c.service.EstimateScene, &v1.EstimateSceneRequest{Spec: input.spec})
}

// GetScene asks for state and memory of a scene.
func (c *Client) GetScene(ctx context.Context, sceneID string) (*Scene, error) {
	answer, err := call(ctx, c, sceneID, c.service.GetScene, &v1.GetSceneRequest{SceneId: sceneID})
	if err != nil {
		return nil, err
	}
	return answer.GetScene(), checkScene(answer.GetScene())
}

// ListScenes lists this client's scenes, by id. All pages together take no longer than a call may.
func (c *Client) ListScenes(ctx context.Context) (scenes []*Scene, err error) {
	ctx, cancel := c.connector.limited(ctx)
	defer cancel()
	for token := ""; ; {
		page, err := call(ctx, c, "", c.service.ListScenes, &v1.ListScenesRequest{PageToken: token})
		if err != nil {
			return nil, err
		}
		for _, scene := range page.Scenes {
			if last := len(scenes) - 1; last >= 0 && scene.SceneId <= scenes[last].SceneId {
				return nil, failf(codes.DataLoss, "", "scenes names '%s' after '%s'; ids must ascend",
					scene.SceneId, scenes[last].SceneId)
			}
			scenes = append(scenes, scene)
		}
		if token = page.NextPageToken; token == "" {
			return scenes, nil
		}
		if len(page.Scenes) == 0 || len(scenes) >= maxScenes {
			return nil, failf(codes.DataLoss, "", "next_page_token is set after a page of %d scenes, %d in all",
				len(page.Scenes), len(scenes))
		}
	}
}

// DeleteScene deletes a scene and frees its memory; its stream ends with NotFound.
func (c *Client) DeleteScene(ctx context.Context, sceneID string) error {
	_, err := call(ctx, c, sceneID, c.service.DeleteScene, &v1.DeleteSceneRequest{SceneId: sceneID})
	return err
}

// Detect is one frame, one answer, of a scene without an open stream. frame.ID is needed. It fails if the frame is refused.
func (c *Client) Detect(ctx context.Context, scene *Scene, frame Frame) (*Output, error) {
	message, err := frame.message(scene.GetSpec().GetPositionFormat())
	if err != nil {
		return nil, err
	}
	request := &v1.DetectFrameRequest{SceneId: scene.GetSceneId(), Frame: message}
	answer, err := call(ctx, c, scene.GetSceneId(), c.service.DetectFrame, request)
	if err != nil {
		return nil, err
	}
	output := newOutput(message)
	if err := output.add(fieldContacts, answer.Contacts...); err != nil {
		return nil, err
	}
	if err := output.finish(answer.Done); err != nil {
		return nil, err
	}
	return output, output.checkTotal()
}

// Stream opens a stream, on a connection of its own to the scene's endpoint, which it waits for. The stream ends with ctx.
func (c *Client) Stream(ctx context.Context, scene *Scene, options StreamOptions) (*Stream, error) {
	connection, err := c.connector.connect(ctx, scene.GetEndpoint())
	if err != nil {
		return nil, err
	}
	id := scene.GetSceneId()
	return openStream(c.connector.streamContext(ctx, id), connection, id, options, c.info.GetLimits().GetMaxMessageBytes(),
		c.connector.options.Deadline, c.features)
}

// Resume resumes a scene whose stream broke, and takes it over from one that may still be open: send the frames after the new
// stream's Scene().LastFrameId again.
func (c *Client) Resume(ctx context.Context, scene *Scene, options StreamOptions) (*Stream, error) {
	options.ResumeToken = scene.GetResumeToken()
	return c.Stream(ctx, scene, options)
}

// Watch watches the frames that others send to a scene of this client, on a connection of its own. The watch ends with ctx.
func (c *Client) Watch(ctx context.Context, sceneID string, options WatchOptions) (*Watcher, error) {
	connection, err := c.connector.connect(ctx, "")
	if err != nil {
		return nil, err
	}
	return openWatcher(c.connector.streamContext(ctx, sceneID), connection, sceneID, options, c.connector.options.Deadline, c.features)
}

// Session creates a scene and a stream that survive the loss of the connection and of the daemon. The session ends with ctx.
func (c *Client) Session(ctx context.Context, spec *SceneSpec, meshes []Mesh, options SessionOptions) (*Session, error) {
	input, err := newSceneInput(spec, meshes)
	if err != nil {
		return nil, err
	}
	return openSession(ctx, c.connector, input, options)
}

func call[Q, A any](ctx context.Context, c *Client, sceneID string,
	method func(context.Context, *Q, ...grpc.CallOption) (*A, error), request *Q) (*A, error) {
	if lack := c.features.CheckCall(any(request).(proto.Message)); lack != nil {
		return nil, errorOfLack(lack)
	}
	ctx, cancel := c.connector.callContext(ctx, sceneID, 0)
	defer cancel()
	answer, err := method(ctx, request)
	return answer, errorOf(err)
}

func sleep(ctx context.Context, pause time.Duration) error {
	select {
	case <-time.After(pause):
		return nil
	case <-ctx.Done():
		return contextError(ctx.Err())
	}
}

// randomID has 128 random bits as hexadecimal digits.
func randomID() string {
	var bits [16]byte
	if _, err := rand.Read(bits[:]); err != nil {
		panic(err) // the system has no randomness
	}
	return hex.EncodeToString(bits[:])
}

func min(a, b int) int {
	if a < b {
		return a
	}
	return b
}
