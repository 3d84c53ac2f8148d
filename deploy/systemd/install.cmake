# Installs the units of this build, the system user's description and, where there is none yet, the configuration.
set(here ${PROJECT_SOURCE_DIR}/deploy/systemd)
set(written ${CMAKE_CURRENT_BINARY_DIR}/installed)
set(BINDIR ${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR})
set(SYSCONFDIR ${CMAKE_INSTALL_PREFIX}/etc)
if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  set(SYSCONFDIR /etc)
endif()

set(TYPE exec)
if(COLLIDED_HAVE_SYSTEMD)
  set(TYPE notify)
  set(WATCHDOG "# A daemon that is stuck is killed and started again.\nWatchdogSec=30\n")
endif()
# What the driver of a GPU needs: its devices, and memory that is written and executed.
set(DEVICES "PrivateDevices=yes\nPrivateIPC=yes\nProtectProc=invisible\nMemoryDenyWriteExecute=yes")
if(COLLIDED_HAVE_CUDA)
  set(AND_GPUS " and GPUs")
  set(AFTER " collided-nvidia.service")
  set(RELATIONS "Wants=collided-nvidia.service\n")
  set(DEVICES "DevicePolicy=closed\nDeviceAllow=char-nvidia* rw")
  # The user has no home folder, where the driver would keep them.
  set(KERNEL_CACHE "\
# Kernels that the driver has compiled for GPUs that the build has no code for.
CacheDirectory=collided
CacheDirectoryMode=0700
Environment=CUDA_CACHE_PATH=/var/cache/collided/cuda CUDA_CACHE_MAXSIZE=1073741824\n")
endif()

set(RUNTIME collided)
configure_file(${here}/collided.service.in ${written}/collided.service @ONLY)
set(units ${written}/collided.service)
if(COLLIDED_HAVE_CUDA)
  set(OF_GPU " on GPU %i")
  set(RUNTIME collided-%i)
  string(APPEND AFTER " collided.service")
  string(APPEND RELATIONS "# The other daemon has all GPUs.\nConflicts=collided.service\n")
  set(ENVIRONMENT "\
# The GPU as nvidia-smi numbers it. Addresses here override the file's; gpu-%i.env overrides both.
Environment=CUDA_DEVICE_ORDER=PCI_BUS_ID CUDA_VISIBLE_DEVICES=%i
Environment=COLLIDED_NAME=gpu-%i
Environment=COLLIDED_ADDRESS=127.0.0.1:5055%i,unix:/run/collided-%i/socket
Environment=COLLIDED_HTTP_ADDRESS=127.0.0.1:946%i
EnvironmentFile=-${SYSCONFDIR}/collided/gpu-%i.env\n")
  configure_file(${here}/collided.service.in ${written}/collided@.service @ONLY)
  list(APPEND units ${written}/collided@.service ${here}/collided-nvidia.service)
endif()
file(INSTALL ${units} DESTINATION ${CMAKE_INSTALL_PREFIX}/lib/systemd/system)
file(INSTALL ${here}/collided.sysusers DESTINATION ${CMAKE_INSTALL_PREFIX}/lib/sysusers.d RENAME collided.conf)

# The documented defaults, with the addresses of a service.
function(replace default ours)
  string(FIND "${config}" "${default}" found)
  if(found EQUAL -1)
    message(FATAL_ERROR "deploy/collided.toml has no '${default}'")
  endif()
  string(REPLACE "${default}" "${ours}" config "${config}")
  set(config "${config}" PARENT_SCOPE)
endfunction()

if(NOT EXISTS $ENV{DESTDIR}${SYSCONFDIR}/collided/collided.toml)
  file(READ ${PROJECT_SOURCE_DIR}/deploy/collided.toml config)
  replace([[Use it with --config FILE, test it with --check.]] "Read again by systemctl reload collided.")
  replace([[# deploy/README.md explains them.]] "# man collided.toml explains them.")
  replace([=[["127.0.0.1:50551"]]=] [=[["127.0.0.1:50551", "unix:/run/collided/socket"]]=])
  replace([[http-address = ""              #]] [[http-address = "127.0.0.1:9464"  #]])
  file(WRITE ${written}/collided.toml "${config}")
  file(INSTALL ${written}/collided.toml DESTINATION ${SYSCONFDIR}/collided)
endif()
