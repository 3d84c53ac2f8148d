/* Drops a point of a tetrahedron through a triangle and prints when it passes. */
#include <collided/collided.h>
#include <stdio.h>

static int failed(collided_status status, const char* what) {
  if (status != COLLIDED_OK) fprintf(stderr, "%s: %s (status %d)\n", what, collided_error_message(), (int)status);
  return status != COLLIDED_OK;
}

int main(void) {
  static const uint32_t floor_triangles[] = {0, 1, 2}, body_triangles[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  static const float floor_positions[] = {-5, -5, 0, 5, -5, 0, 0, 5, 0};
  static const float body[] = {0, 0, 1, 1, 0, 2, 0, 1, 2, -1, -1, 2};
  collided_mesh meshes[2] = {{.struct_size = sizeof(collided_mesh)}, {.struct_size = sizeof(collided_mesh)}};
  collided_scene_spec spec = {.struct_size = sizeof spec, .meshes = meshes, .mesh_count = 2};
  collided_scene* scene;
  int step, i;

  meshes[0].vertex_count = 3;
  meshes[0].triangles = floor_triangles;
  meshes[0].triangle_count = 1;
  meshes[0].motion = COLLIDED_STATIC;
  meshes[1].vertex_count = 4;
  meshes[1].triangles = body_triangles;
  meshes[1].triangle_count = 4;
  if (failed(collided_scene_create(&spec, &scene), "scene")) return 1;

  for (step = 0; step < 4; ++step) {
    float positions[12];
    collided_update updates[2] = {{.struct_size = sizeof(collided_update)}, {.struct_size = sizeof(collided_update)}};
    collided_frame frame = {.struct_size = sizeof frame, .updates = updates, .update_count = step == 0 ? 2 : 1};
    collided_contacts contacts = {.struct_size = sizeof contacts};
    collided_result* result;
    uint64_t k;
    for (i = 0; i < 12; ++i) positions[i] = body[i] - (i % 3 == 2 ? 0.4f * (float)step : 0);
    updates[0].mesh = 1;
    updates[0].end = positions;
    updates[0].end_bytes = sizeof positions;
    updates[1].mesh = 0;
    updates[1].end = floor_positions;
    updates[1].end_bytes = sizeof floor_positions;
    if (failed(collided_detect(scene, &frame, &result), "frame")) return 1;
    if (failed(collided_result_contacts(result, COLLIDED_VERTEX_TRIANGLE, &contacts), "contacts")) return 1;
    printf("step %d: %d contacts\n", step, (int)contacts.count);
    for (k = 0; k < contacts.count; ++k)
      printf("  vertex %u, triangle %u, t = %.4f\n", contacts.elements[2 * k], contacts.elements[2 * k + 1], contacts.toi[k]);
    collided_result_free(result);
  }
  collided_scene_free(scene);
  return 0;
}
