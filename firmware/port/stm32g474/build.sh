#!/usr/bin/env bash
# Builds the board's image and checks it: build.sh OUTPUT_FOLDER. Ends with `N passed, N failed`.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../../.." && pwd)
out=${1:?usage: build.sh OUTPUT_FOLDER}
rm -rf "$out"
mkdir -p "$out"
out=$(cd "$out" && pwd)
cd "$root"

target=(-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard)
flags=(-std=c++20 -O2 -g "${target[@]}" -fno-exceptions -fno-rtti -fno-threadsafe-statics -fno-math-errno
  -ffp-contract=off -ffunction-sections -fdata-sections -fstack-usage -fcallgraph-info=su
  -Wall -Wextra -Wpedantic -Wshadow -Wdouble-promotion -Wno-psabi -Werror -I.)
# who made it: the commit, and whether the sources are those of the commit
commit=$(git rev-parse --short=12 HEAD 2>/dev/null || echo unknown)
if [[ $commit != unknown && -n $(git status --porcelain -- core firmware) ]]; then commit+=-dirty; fi
flags+=("-DPOWBENCH_COMMIT=\"$commit\"")
# without ccache, which does not keep the call graphs

# the portable core and this port; other ports are programs of their own
find firmware -name '*.cpp' \( -not -path 'firmware/port/*' -o -path 'firmware/port/stm32g474/*' \) | sort >"$out/sources"
compile() {
  local object=$1/${2//\//_} small=()
  # what only talks to a host is built small, what a sample waits for is built fast
  case $2 in
    */control_device.cpp | */source_device.cpp | */identity.cpp | */sealed_shot.cpp | */calibration.cpp | */controller_calibration.cpp | */bench_devices.cpp | */iiod/*.cpp) small=(-Os) ;;
    # once a millisecond or less
    */phase_bank.cpp | */phase_predictor.cpp | */fire_control.cpp | */fire_step.cpp | */calibration_store.cpp | */stm32g474/main.cpp) small=(-Os) ;;
  esac
  shift 2
  "$@" "${small[@]}" -o "${object%.cpp}.o"
}
export -f compile
xargs -P "$(nproc)" -I{} bash -c 'compile "$@"' _ "$out" {} arm-none-eabi-g++ "${flags[@]}" -c {} <"$out/sources"
arm-none-eabi-g++ "${target[@]}" -nostartfiles --specs=nano.specs -Wl,--gc-sections -Wl,--fatal-warnings \
  -T "$here/link.ld" -Wl,-Map="$out/board.map" "$out"/*.o -o "$out/board.elf"
arm-none-eabi-objcopy -O binary "$out/board.elf" "$out/board.bin"
bash "$here/check_image.sh" "$out/board.elf" "$out"
