#include "tests/hardware/allocation_count.h"

#include <cstdlib>
#include <new>

namespace {

thread_local long allocation_count = 0;

void* counted(std::size_t size) {
  ++allocation_count;
  // NOLINTNEXTLINE(cppcoreguidelines-no-malloc): operator new itself
  void* memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

namespace handgraft::test {

long allocationCount() {
  return allocation_count;
}

}  // namespace handgraft::test

void* operator new(std::size_t size) {
  return counted(size);
}

void* operator new[](std::size_t size) {
  return counted(size);
}

void operator delete(void* memory) noexcept {
  std::free(memory);
}

void operator delete[](void* memory) noexcept {
  std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}
