#pragma once

#include "catch.h"
#include "layout_checks.h"

/// \file What the tests of Fresco's own layouts begin with.

using namespace fresco;
using namespace fresco::testing;

/// The forms in which the layout writes recordings; every test program of a layout has its own.
std::vector<LayoutUnderTest> forms();

TEST_CASE("a recording holds what every recording does", "[layout]")
{
    for (const LayoutUnderTest& form : forms())
        check_layout(form);
}
