#pragma once

#include "catch.h"
#include "reader_checks.h"

/// \file What the tests of Fresco's own readers begin with.

using Catch::Contains;
using namespace fresco;
using namespace fresco::testing;
