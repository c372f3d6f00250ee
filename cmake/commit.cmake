cmake_minimum_required(VERSION 3.25)
# Writes FILE with the commit of the sources in SOURCE, only when it differs. A release without git names it in SOURCE/.commit.
set(commit "")
if(EXISTS ${SOURCE}/.git)
  execute_process(COMMAND git -c safe.directory=* describe --always --dirty --abbrev=12 --exclude=*
    WORKING_DIRECTORY ${SOURCE} OUTPUT_VARIABLE commit ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
elseif(EXISTS ${SOURCE}/.commit)
  file(READ ${SOURCE}/.commit commit)
  string(STRIP "${commit}" commit)
endif()
if(commit STREQUAL "")
  set(commit "not known")
endif()
file(CONFIGURE OUTPUT ${FILE} CONTENT
"// The commit that this program was built from.
namespace powbench::host {
extern const char* const program_commit;
const char* const program_commit = \"@commit@\";
}  // namespace powbench::host
" @ONLY)
