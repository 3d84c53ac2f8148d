#pragma once
// The C++ client. Programs include this header; the paths below remain usable up to version 0.2 and may change after
// it.

#include "client/cpp/batch/scene_set.hpp"
#include "client/cpp/client.hpp"
#include "client/cpp/contours.hpp"
#include "client/cpp/positions.hpp"
#include "client/cpp/session.hpp"
#include "client/cpp/watcher.hpp"
