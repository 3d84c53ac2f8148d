#pragma once
// The engine in this process as a daemon of the C++ client.

#include "client/cpp/session.hpp"
#include "client/in_process/local.hpp"
