# npm ci in the build's folder. What fails is told and fails nothing else: the next build tries again.
if(NOT NPM OR NOT NODE)
  message(NOTICE "no page is built: nodejs and npm are not installed; `handgraft view` needs it, nothing else")
  return()
endif()
configure_file(${SOURCE}/package.json package.json COPYONLY)
configure_file(${SOURCE}/package-lock.json package-lock.json COPYONLY)
set(parts --omit=dev)
if(DEV)
  set(parts)
endif()
# No package runs a script of its own.
execute_process(
  COMMAND ${NPM} ci ${parts} --ignore-scripts --no-audit --no-fund --fetch-retries=1 --fetch-timeout=30000
  RESULT_VARIABLE failed OUTPUT_VARIABLE log ERROR_VARIABLE log)
if(failed)
  file(REMOVE node_modules/.package-lock.json)
  message(NOTICE "no page is built: npm does not get its packages; `handgraft view` needs it, nothing else\n${log}")
else()
  file(TOUCH node_modules/.package-lock.json)
endif()
