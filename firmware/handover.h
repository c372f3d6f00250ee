#pragma once

/// Words that two priority levels of one processor share. The lower level never interrupts the higher one, so a
/// word that is written whole and in order is all it takes.

namespace powbench::firmware {

template <class T>
T load_shared(const T& word) {
  return __atomic_load_n(&word, __ATOMIC_ACQUIRE);
}
template <class T>
void store_shared(T& word, T value) {
  __atomic_store_n(&word, value, __ATOMIC_RELEASE);
}

}  // namespace powbench::firmware
