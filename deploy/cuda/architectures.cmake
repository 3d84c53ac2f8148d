# COLLIDED_CUDA_ARCHITECTURES, as the list that CMake compiles for.

# Code for Turing (75), Ampere (80; 86 runs it), Ada (89 runs that of 80), Hopper (90) and Blackwell (100, and 120 of
# graphics cards). PTX of 75 for all that have no code of their own, of 120 for what comes after.
set(COLLIDED_RELEASE_ARCHITECTURES 75 80-real 90-real 100-real 120)

# Before enable_language(CUDA), which takes the list.
macro(collided_set_cuda_architectures)
  if(COLLIDED_CUDA_ARCHITECTURES STREQUAL "release")
    set(CMAKE_CUDA_ARCHITECTURES ${COLLIDED_RELEASE_ARCHITECTURES})
  elseif(COLLIDED_CUDA_ARCHITECTURES STREQUAL "native")
    execute_process(COMMAND nvidia-smi --query-gpu=compute_cap --format=csv,noheader
      OUTPUT_VARIABLE capabilities RESULT_VARIABLE failed ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
    string(REGEX MATCHALL "[0-9]+[.][0-9]+" capabilities "${capabilities}")
    if(failed OR NOT capabilities)
      message(FATAL_ERROR "COLLIDED_CUDA_ARCHITECTURES=native, but nvidia-smi tells of no GPU on this machine")
    endif()
    list(REMOVE_DUPLICATES capabilities)
    string(REPLACE "." "" CMAKE_CUDA_ARCHITECTURES "${capabilities}")
  elseif(COLLIDED_CUDA_ARCHITECTURES)
    set(CMAKE_CUDA_ARCHITECTURES ${COLLIDED_CUDA_ARCHITECTURES})
  elseif(NOT CMAKE_CUDA_ARCHITECTURES)
    set(CMAKE_CUDA_ARCHITECTURES 90)
  endif()
  # At run time devices are checked against this list, so it has to name them.
  if(NOT CMAKE_CUDA_ARCHITECTURES MATCHES "^[0-9]+[af]?(-real|-virtual)?(;[0-9]+[af]?(-real|-virtual)?)*$")
    message(FATAL_ERROR "'${CMAKE_CUDA_ARCHITECTURES}' is no list of CUDA architectures, such as 80-real;90")
  endif()
endmacro()

# After it: the compiler is known. CUDA 12.8 was the first with Blackwell, and with --compress-mode.
function(collided_check_cuda_architectures)
  if(NOT COLLIDED_CUDA_ARCHITECTURES STREQUAL "release")
    return()
  endif()
  if(CMAKE_CUDA_COMPILER_VERSION VERSION_LESS 12.8)
    message(FATAL_ERROR "COLLIDED_CUDA_ARCHITECTURES=release needs nvcc 12.8 or later, and this is "
      "${CMAKE_CUDA_COMPILER_VERSION}; name the architectures that it knows instead, such as 75;80-real;90")
  endif()
  add_compile_options("$<$<COMPILE_LANGUAGE:CUDA>:--compress-mode=size>")
endfunction()
