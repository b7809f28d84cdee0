#pragma once

// Four doubles side by side, for kernels that are worth it (in .cpp files alone).

namespace handgraft::geometry {

// Compiled twice, and chosen when the program starts: four doubles at once take one instruction
// of AVX2 and two without. No fused multiplication, so that both say the same to the last bit.
// Sanitizers are not ready yet when that choice is made.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define HANDGRAFT_WIDE [[gnu::target_clones("avx2", "default")]]
#else
#define HANDGRAFT_WIDE
#endif

using Lanes = double __attribute__((vector_size(32)));

}  // namespace handgraft::geometry
