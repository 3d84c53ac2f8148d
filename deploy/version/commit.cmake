# Writes HEADER with the commit of SOURCES: COMMIT, else what GIT says, else "unknown".
if(NOT COMMIT AND GIT AND EXISTS ${SOURCES}/.git)
  execute_process(COMMAND ${GIT} describe --always --dirty=\ \(modified\) --abbrev=12 --exclude=*
    WORKING_DIRECTORY ${SOURCES} OUTPUT_VARIABLE COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT COMMIT)
  set(COMMIT unknown)
endif()
file(CONFIGURE OUTPUT ${HEADER} CONTENT "#define COLLIDED_COMMIT \"@COMMIT@\"\n" @ONLY)
