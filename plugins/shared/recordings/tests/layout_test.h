#pragma once

#include "catch.h"
#include "layout_checks.h"

/// \file What the tests of Fresco's own layouts begin with.

using Catch::Contains;
using namespace fresco;
using namespace fresco::testing;
