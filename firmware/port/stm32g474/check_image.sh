#!/usr/bin/env bash
# Checks the board's image without running it: check_image.sh ELF FOLDER_WITH_CALL_GRAPHS. Ends with `N passed, N failed`.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
elf=$1 graphs=$2
passed=0 failed=0

# verdict NAME VALUE CONDITION: CONDITION is an arithmetic expression.
verdict() {
  if (($3)); then
    passed=$((passed + 1))
    printf 'ok      %-34s %s\n' "$1" "$2"
  else
    failed=$((failed + 1))
    printf 'FAILED  %-34s %s\n' "$1" "$2"
  fi
}

symbol() { arm-none-eabi-nm "$elf" | awk -v name="$1" '$3 == name { print "0x" $1; found = 1 } END { exit !found }'; }
section() { arm-none-eabi-size -A -d "$elf" | awk -v name="$1" -v column="$2" '$1 == name { print $column }'; }
word() { arm-none-eabi-objdump -s -j .vectors --start-address="$1" --stop-address="$(($1 + 4))" "$elf" |
  awk 'NF >= 2 && $1 ~ /^[0-9a-f]+$/ { w = $2; print "0x" substr(w,7,2) substr(w,5,2) substr(w,3,2) substr(w,1,2) }'; }

flash_start=$((0x08000000)) flash_end=$((0x08040000)) ram_start=$((0x20000000)) ram_end=$((0x20020000))
stack_top=$(symbol stack_top) stack_bottom=$(symbol stack_bottom) reset=$(symbol reset_handler)
text_start=$(section .text 3)
text_end=$((text_start + $(section .text 2)))

# --- where things lie ---
vectors=$(section .vectors 3)
verdict "vector table at the start of flash" "$(printf '0x%08x' "$vectors")" "$vectors == $flash_start"
verdict "vector table has all entries" "$(section .vectors 2) B" "$(section .vectors 2) == 4 * (16 + 102)"
record_end=$(($(section .record 3) + $(section .record 2)))
verdict "memory in use" "$((record_end - ram_start)) of $((ram_end - ram_start)) B" "$record_end <= $ram_end"
flash_use=$(($(section .vectors 2) + $(section .text 2) + $(section .ARM.exidx 2) + $(section .data 2)))
verdict "flash in use" "$flash_use of $((flash_end - flash_start)) B" "$flash_use < 80 * 1024"
verdict "record" "$(section .record 2) B" "$(section .record 2) >= 6000 * 16"
verdict "stack at the bottom of memory" "$stack_bottom" "$stack_bottom == $ram_start && $stack_top % 8 == 0"

table=$(arm-none-eabi-nm -C "$elf" | awk '$3 == "powbench::firmware::fault_table" { print "0x" $1 }')
verdict "table of faults in flash" "$table" "$table >= $flash_start && $table < $flash_end"

# --- vectors ---
first=$(word "$vectors")
verdict "stack pointer in the vector table" "$first" "$first == $stack_top"
second=$(word $((vectors + 4)))
verdict "reset vector" "$second" "$second == ($reset | 1)"
bad=0
for ((i = 1; i < 16 + 102; ++i)); do
  entry=$(($(word $((vectors + 4 * i)))))
  if ((entry % 2 != 1 || entry < text_start || entry >= text_end)); then bad=$((bad + 1)); fi
done
verdict "vectors outside the code or not Thumb" "$bad" "$bad == 0"
fault=$(($(symbol fault_handler) | 1))
for number in 2 3 4 5 6; do
  if (($(word $((vectors + 4 * number))) != fault)); then bad=$((bad + 1)); fi
done
verdict "NMI and faults lead to fault_handler" "$bad wrong" "$bad == 0"
opening=$(arm-none-eabi-objdump -d --disassemble=fault_handler "$elf" | awk -F'\t' '/^ *[0-9a-f]+:/ { print $3 }' |
  head -n 4 | tr '\n' ' ')
verdict "fault_handler opens with the gate off" "$opening" "$([[ $opening == "movw movt movs str " ]] && echo 1 || echo 0)"

# --- what must not be there ---
none() {
  local found
  found=$(arm-none-eabi-nm -C "$elf" | awk '{ $1 = $2 = ""; print }' | grep -E "$2" | head -n 3 | tr '\n' ' ') || true
  verdict "$1" "${found:-none}" "$([[ -z $found ]] && echo 1 || echo 0)"
}
none "heap" ' (operator (new|delete)|_?(malloc|free|calloc|realloc|sbrk)(_r)?$)'
none "exceptions" '__cxa_|_Unwind_|__gxx_personality|std::__throw'
none "type information" 'typeinfo (for|name for)'
none "system calls and formatted output" ' _?(write|read|open|close|exit|printf|snprintf|vsnprintf|puts)(_r)?$'
semihosting=$(arm-none-eabi-objdump -d "$elf" | grep -cE 'bkpt' || true)
verdict "breakpoint instructions" "$semihosting" "$semihosting == 0"

# --- stack: the deepest path of each level, and an exception frame with floating-point registers for each interrupt ---
# functions whose address is taken: they stand in a table, a vtable or a literal
arm-none-eabi-readelf -rW "$graphs"/*.o | awk '
  /^Relocation section/ { keep = $3 !~ /debug|exidx|\.vectors/ }
  keep && $3 == "R_ARM_ABS32" { sub(/^\.text\./, "", $5); print $5 }' | sort -u >"$graphs/taken"
awk -f "$here/stack_use.awk" "$graphs/taken" "$graphs"/*.ci | tee "$graphs/stack.txt"
worst=$(awk '$1 == "total" { print $2 }' "$graphs/stack.txt")
verdict "worst stack" "$worst of $((stack_top - stack_bottom)) B" "${worst:-0} > 0 && ${worst:-0} <= $stack_top - $stack_bottom"

printf '%d passed, %d failed\n' "$passed" "$failed"
((failed == 0))
