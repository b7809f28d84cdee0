# node bundle.mjs, where its packages are.
if(NOT EXISTS node_modules/.package-lock.json)
  return()  # fetch.cmake has said why
endif()
execute_process(COMMAND ${NODE} ${SOURCE}/bundle.mjs ${OUT} COMMAND_ERROR_IS_FATAL ANY)
