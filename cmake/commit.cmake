cmake_minimum_required(VERSION 3.25)
# Writes FILE with the commit of the sources in SOURCE, only when it differs; behind "-dirty" a hash of what is changed.
# A release without git names it in SOURCE/.commit.
set(commit "")
if(EXISTS ${SOURCE}/.git)
  execute_process(COMMAND git -c safe.directory=* describe --always --dirty --abbrev=12 --exclude=*
    WORKING_DIRECTORY ${SOURCE} OUTPUT_VARIABLE commit ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(commit MATCHES "-dirty$")
    execute_process(COMMAND git -c safe.directory=* diff HEAD COMMAND git hash-object --stdin
      WORKING_DIRECTORY ${SOURCE} OUTPUT_VARIABLE changes ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
    string(SUBSTRING "${changes}" 0 12 changes)
    string(APPEND commit "-${changes}")
  endif()
elseif(EXISTS ${SOURCE}/.commit)
  file(READ ${SOURCE}/.commit commit)
  string(STRIP "${commit}" commit)
endif()
if(commit STREQUAL "")
  set(commit "not known")
endif()
file(CONFIGURE OUTPUT ${FILE} CONTENT
"#include \"host/cli/program.h\"
namespace powbench::host {
const char* const program_commit = \"@commit@\";
}
" @ONLY)
