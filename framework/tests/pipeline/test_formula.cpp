#include <catch2/catch.hpp>

#include "hand_made_catalog.h"

#include "base/glob.h"
#include "pipeline/formula.h"
#include <fresco/error.h>

#include <map>

using namespace fresco::host;
using fresco::host::testing::TemporaryFolder;

namespace
{
class FixedNames final : public FormulaNames
{
  public:
    std::optional<double> value(std::string_view name) override
    {
        const auto found = values.find(name);
        return found == values.end() ? std::nullopt : std::optional(found->second);
    }
    std::optional<double> count(std::string_view option, std::string_view glob) override
    {
        return option == "path" ? std::optional(static_cast<double>(glob.size())) : std::nullopt;
    }
    std::optional<double> bytes(std::string_view option, std::string_view) override
    {
        return option == "path" ? std::optional(1000.0) : std::nullopt;
    }

    std::map<std::string, double, std::less<>> values{{"frames", 10}, {"max_faces", 4}, {"zero", 0}, {"huge", 1e300}};
};

double value_of(const std::string& formula)
{
    FixedNames names;
    return evaluate_formula(formula, names);
}

std::string error_of(const std::string& formula)
{
    try
    {
        value_of(formula);
    }
    catch (const fresco::Error& error)
    {
        return error.what();
    }
    return "no error";
}
}  // namespace

TEST_CASE("Formulas are computed as they are read in school", "[formula]")
{
    CHECK(value_of("1 + 2 * 3") == 7);
    CHECK(value_of("(1 + 2) * 3") == 9);
    CHECK(value_of("8 - 4 - 2") == 2);
    CHECK(value_of("8 / 4 / 2") == 1);
    CHECK(value_of("-frames + -2 * -3") == -4);
    CHECK(value_of("2e-6*frames") == Approx(2e-5));
    CHECK(value_of(".5") == 0.5);
    CHECK(value_of("min(frames, max_faces, 7)") == 4);
    CHECK(value_of("max(1, min(2, 3)) + count(path, \"*.png\") / 5") == 3);
    CHECK(value_of(" bytes( path ) / 10 ") == 100);
}

TEST_CASE("A formula that cannot be computed says where and why", "[formula]")
{
    using Catch::Matchers::Contains;
    CHECK_THAT(error_of("1 / zero"), Contains("character 4: division by zero"));
    CHECK_THAT(error_of("1 + framez"), Contains("character 5: 'framez' is no name"));
    CHECK_THAT(error_of("huge * huge"), Contains("larger than any number"));
    CHECK_THAT(error_of("1e999"), Contains("no number"));
    CHECK_THAT(error_of("1 +"), Contains("expected at the end"));
    CHECK_THAT(error_of(""), Contains("expected at the end"));
    CHECK_THAT(error_of("(1"), Contains("')' is expected"));
    CHECK_THAT(error_of("1 2"), Contains("an operator is expected before '2'"));
    CHECK_THAT(error_of("sin(1)"), Contains("no function 'sin'"));
    CHECK_THAT(error_of("count(nothing, \"*\")"), Contains("'nothing' is no option"));
    CHECK_THAT(error_of("count(path, \"*)"), Contains("never closed"));
    CHECK_THAT(error_of(std::string(900, '(')), Contains("nested too deep"));
    CHECK_THAT(error_of(std::string(900, '-') + "1"), Contains("nested too deep"));
    CHECK_THAT(error_of(std::string(2000, '1')), Contains("too long"));
}

TEST_CASE("Patterns match whole names", "[formula]")
{
    CHECK(name_matches("frame-000001.pose.txt", "frame-*.pose.txt"));
    CHECK_FALSE(name_matches("frame-000001.pose.txt~", "frame-*.pose.txt"));
    CHECK(name_matches("abc", "a?c"));
    CHECK(name_matches("aXbXc", "*X*c"));
    CHECK_FALSE(name_matches("abc", "a?"));
    CHECK(name_matches("", "*"));
    CHECK_FALSE(name_matches("", "?"));
    CHECK_FALSE(name_matches(std::string(5000, 'a'), "*a*a*a*a*a*a*a*b"));
}

TEST_CASE("Files below a folder are counted with their bytes", "[formula]")
{
    const TemporaryFolder folder;
    folder.write("a.png", "1234");
    folder.write("b.png", "12");
    folder.write("seq-01/a.png", "1");
    folder.write("seq-01/deep/c.png", "123");
    folder.write("seq-02/x.txt", "");
    std::filesystem::create_directory_symlink(folder.path(), folder.path() / "seq-01" / "loop");
    const auto measure = [&](const char* pattern)
    {
        const GlobMeasure result = measure_files(folder.path(), pattern);
        return std::pair(result.files, result.bytes);
    };
    CHECK(measure("*.png") == std::pair<std::uint64_t, std::uint64_t>(2, 6));
    CHECK(measure("seq-*/*.png") == std::pair<std::uint64_t, std::uint64_t>(1, 1));
    CHECK(measure("**/*.png") == std::pair<std::uint64_t, std::uint64_t>(4, 10));
    CHECK(measure("seq-*/**") == std::pair<std::uint64_t, std::uint64_t>(3, 4));
    CHECK(measure("") == std::pair<std::uint64_t, std::uint64_t>(5, 10));
    CHECK(measure("none") == std::pair<std::uint64_t, std::uint64_t>(0, 0));
    CHECK(measure_files(folder.path() / "a.png", "").bytes == 4);
    CHECK(measure_files(folder.path() / "missing", "*").files == 0);
    CHECK(measure_files(folder.path(), "**/*.png", 3).cut_short);
}
