#pragma once

#include <gtest/gtest.h>

/// Skips the test, with the reason, in a build that wraps no skin and makes no surface of
/// points (HANDGRAFT_WITH_CGAL=OFF). Tests that take skins from the cache run there on skins
/// that are given: copy tests/cache of another build.
#ifdef HANDGRAFT_WITHOUT_CGAL
#define HANDGRAFT_NEEDS_CGAL() GTEST_SKIP() << "needs CGAL; this build is without"
#else
#define HANDGRAFT_NEEDS_CGAL() (void)0
#endif
