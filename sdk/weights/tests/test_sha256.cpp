#include "made_weights.h"

#include <fresco/error.h>
#include <fresco/weights/sha256.h>

using namespace fresco::weights;

TEST_CASE("SHA-256 of one of the standard's examples and of files")
{
    const auto million = bytes_of(std::string(1'000'000, 'a'));
    CHECK(sha256(million) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
    const auto file = made_weights() / "legacy.pth";
    CHECK(sha256_of_file(file) == sha256(fresco::read_file(file)));
    CHECK_THROWS_AS(sha256_of_file(made_weights() / "none"), fresco::MissingInput);
    CHECK_THROWS_AS(sha256_of_file(made_weights()), fresco::MissingInput);
}

TEST_CASE("Beginnings of a SHA-256")
{
    CHECK(is_sha256_prefix("DCBB9e9D"));
    CHECK_FALSE(is_sha256_prefix("dcbb9e9"));
    CHECK_FALSE(is_sha256_prefix("dcbb9e9x"));
    CHECK_FALSE(is_sha256_prefix(std::string(65, 'a')));
    CHECK(has_sha256_prefix("dcbb9e9dad", "DCBB9E9D"));
    CHECK_FALSE(has_sha256_prefix("dcbb9e9dad", "dcbb9e9e"));
    CHECK_FALSE(has_sha256_prefix("dcbb", "dcbb9e9e"));
}
