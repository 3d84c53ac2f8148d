/* A program in C: runs frames through the library and hands out what they found. */
#include "run.h"

collided_status run_frames(const collided_scene_spec* spec, const collided_frame* frames, size_t count,
                           take_contacts take, void* context) {
  collided_scene* scene = NULL;
  collided_status status = collided_scene_create(spec, &scene);
  size_t i;
  for (i = 0; i < count && status == COLLIDED_OK; ++i) {
    collided_result* result = NULL;
    int32_t kind;
    status = collided_detect(scene, &frames[i], &result);
    for (kind = COLLIDED_VERTEX_TRIANGLE; kind <= COLLIDED_VERTEX_SOLID && status == COLLIDED_OK; ++kind) {
      collided_contacts contacts = {.struct_size = sizeof contacts};
      status = collided_result_contacts(result, kind, &contacts);
      if (status == COLLIDED_OK) take(context, i, kind, &contacts);
    }
    collided_result_free(result);
  }
  collided_scene_free(scene);
  return status;
}
