#ifndef TESTS_CLIENT_C_RUN_H_
#define TESTS_CLIENT_C_RUN_H_
#include "client/c/include/collided/collided.h"

#ifdef __cplusplus
extern "C" {
#endif
typedef void (*take_contacts)(void* context, size_t frame, int32_t kind, const collided_contacts* contacts);
/* The outcome of the first call that fails, or COLLIDED_OK. */
collided_status run_frames(const collided_scene_spec* spec, const collided_frame* frames, size_t count,
                           take_contacts take, void* context);
#ifdef __cplusplus
}
#endif
#endif
