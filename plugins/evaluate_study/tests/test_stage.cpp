#include "catch.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/testing.h>

#include <algorithm>

using namespace fresco;
using Catch::Contains;
namespace fs = std::filesystem;

namespace
{

/// A picture's "file" is its size and its value: "40x30 7".
struct WrittenOut final : ImageIo
{
    ImageHeader header(const fs::path&) const override { throw Error("not used"); }
    Raster8 read_rgb(const fs::path& file) const override
    {
        int width = 0;
        int height = 0;
        int value = 0;
        REQUIRE(std::sscanf(read_text_file(file).c_str(), "%dx%d %d", &width, &height, &value) == 3);
        return {width, height, 3, static_cast<std::uint8_t>(value)};
    }
    Raster16 read_depth(const fs::path&) const override { throw Error("not used"); }
    std::vector<std::byte> encode_png(const Raster8& image) const override { return encode_jpeg(image, 0); }
    std::vector<std::byte> encode_png(const Raster16&) const override { return {}; }
    std::vector<std::byte> encode_jpeg(const Raster8& image, int) const override
    {
        return {std::byte(image.width), std::byte(image.height), std::byte(image.values[0])};
    }
};

/// Pictures of three views by two methods, below a folder each.
struct Pictures
{
    Pictures()
    {
        for (const char* view : {"one", "two", "three"})
            for (const char* method : {"ours", "theirs"})
                write(method, std::string(view) + ".png", std::string("40x30 ") + (method[0] == 'o' ? "7" : "9"));
    }

    void write(const std::string& method, const std::string& name, const std::string& text) const
    {
        fs::create_directories(folder.path() / "methods" / method);
        write_file(folder.path() / "methods" / method / name, text);
    }

    Value below() const { return Value::Map{{"folder", (folder.path() / "methods").string()}, {"pairs_count", 4}}; }

    std::shared_ptr<Files> files(const std::string& method) const
    {
        auto result = std::make_shared<Files>();
        result->loaded_from = folder.path() / "methods" / method;
        result->names = {"one.png", "two.png", "three.png"};
        return result;
    }

    std::shared_ptr<Files> run_stage(const Value& options, testing::TestRun& run, const testing::Inputs& inputs = {}) const
    {
        fs::remove_all(folder.path() / "out");
        testing::run_stage(FRESCO_PLUGIN_FILE, "evaluate.study", options, inputs, folder.path() / "out", run,
                           {{"image_io", std::make_shared<WrittenOut>()}});
        return Files::load({folder.path() / "out/files", {}});
    }
    std::string made(const char* name) const { return read_text_file(folder.path() / "out/files" / name); }

    testing::TemporaryFolder folder;
};

/// A sheet of one participant who chose the left picture of the key's first pair.
std::string sheet_for(const Value& key, const std::string& participant)
{
    const auto& pictures = key.at("pictures").as_list();
    const std::string& name = pictures[0].at("name").as_string();
    const auto other =
        std::find_if(pictures.begin() + 1, pictures.end(), [&](const Value& p) { return p.at("name").as_string() == name; });
    return to_json(Value::Map{{"format", "fresco.study_answers"},
                              {"version", 1},
                              {"study", key.at("study")},
                              {"participant", participant},
                              {"complete", participant == "p1"},
                              {"answers", Value::List{Value::Map{{"question", 0},
                                                                 {"left", 0},
                                                                 {"right", static_cast<int>(other - pictures.begin())},
                                                                 {"choice", "left"},
                                                                 {"seconds", 2.0}}}}});
}

}  // namespace

TEST_CASE("pictures from subfolders and from ports make the same kind of study")
{
    const Pictures pictures;
    pictures.write("theirs", "alone.png", "40x30 1");
    pictures.write("theirs", "notes.txt", "no picture");
    fs::create_directory(pictures.folder.path() / "methods/.hidden");
    testing::TestRun run;
    const auto files = pictures.run_stage(pictures.below(), run);
    CHECK(files->names == std::vector<std::string>{"study.html", "study.key.json"});
    CHECK(run.reported.at("pictures").as_int() == 6);
    CHECK(run.reported.at("pairs").as_int() == 3);
    CHECK(run.messages.empty());
    CHECK(run.files_read.size() == 6);
    const Value key = parse_json(pictures.made("study.key.json"));
    CHECK(key.at("questions").as_list().size() == 2);
    CHECK(key.at("study") == run.reported.at("study"));
    CHECK_THAT(pictures.made("study.html"), Contains("data:image/jpeg;base64,KB4H") && Contains("data:image/jpeg;base64,KB4J"));

    testing::TestRun by_ports(4);
    pictures.run_stage(Value::Map{{"first_name", "ours"}, {"second_name", "theirs"}, {"pairs_count", 4}}, by_ports,
                       {{"first", pictures.files("ours")}, {"second", pictures.files("theirs")}});
    CHECK(pictures.made("study.key.json") == to_json(key, 1) + "\n");
    CHECK_THROWS_WITH(pictures.run_stage(Value::Map{{"first_name", "x"}, {"second_name", "x"}}, by_ports,
                                         {{"first", pictures.files("ours")}, {"second", pictures.files("theirs")}}),
                      Contains("two methods are named x"));
}

TEST_CASE("pictures of a view are shown at one size, and must be of one shape")
{
    const Pictures pictures;
    pictures.write("theirs", "one.png", "80x60 200");
    testing::TestRun run;
    Value options = pictures.below();
    options.set("max_px", 64);
    options.set("image_format", "png");
    pictures.run_stage(options, run);
    // 40 x 30 and the value 200 (KB7I): the larger one is shrunk to the smaller one's size.
    CHECK_THAT(pictures.made("study.html"), Contains("data:image/png;base64,KB7I"));
    pictures.write("theirs", "one.png", "80x50 200");
    CHECK_THROWS_WITH(pictures.run_stage(options, run), Contains("theirs/one.png is 80x50 and"));
    pictures.write("theirs", "one.jpg", "80x60 200");
    CHECK_THROWS_WITH(pictures.run_stage(options, run), Contains("one.png and") && Contains("share a name"));
}

TEST_CASE("results become percentages, with the same pictures or only the key")
{
    const Pictures pictures;
    testing::TestRun run;
    pictures.run_stage(pictures.below(), run);
    const fs::path key_file = pictures.folder.path() / "kept.key.json";
    write_file(key_file, pictures.made("study.key.json"));
    const Value key = parse_json(pictures.made("study.key.json"));
    const std::string winner = key.at("pictures").as_list()[0].at("method").as_string();
    const fs::path results = pictures.folder.path() / "results";
    fs::create_directory(results);
    Value options = pictures.below();
    options.set("results", results.string());
    CHECK_THROWS_AS(pictures.run_stage(options, run), MissingInput);
    for (const char* participant : {"p1", "p2"})
        write_file(results / (std::string(participant) + ".json"), sheet_for(key, participant));
    write_file(results / "notes.txt", "not read");

    testing::TestRun with_results;
    const auto files = pictures.run_stage(options, with_results);
    CHECK(files->names == std::vector<std::string>{"study.html", "study.key.json", "study.results.json"});
    const std::string figures = pictures.made("study.results.json");
    const Value root = parse_json(figures);
    const Value& comparison = root.at("questions").as_list()[0].at("comparisons").as_list()[0];
    const char* share = winner == "ours" ? "first_share" : "second_share";
    CHECK(comparison.at("first").as_string() == "ours");
    CHECK(comparison.at(share).at("value").as_double() == 1);
    CHECK(comparison.at(share).at("count").as_int() == 2);
    CHECK(comparison.at("preferred").is_null());  // 2 of 2 proves little: [0.34, 1] and [0, 0.66].
    CHECK(with_results.reported.at("participants").as_int() == 2);
    REQUIRE(with_results.messages.size() == 2);
    CHECK_THAT(with_results.messages[0], Contains("1 of 2 participants finished early"));
    CHECK_THAT(with_results.messages[1], Contains("Which picture has less visible stretch?") &&
                                             Contains("100.0 % [34.2, 100.0]") &&
                                             Contains("of 2 answers: no significant preference"));

    testing::TestRun by_key;
    const auto alone = pictures.run_stage(Value::Map{{"key", key_file.string()}, {"results", results.string()}}, by_key);
    CHECK(alone->names == std::vector<std::string>{"study.results.json"});
    CHECK(pictures.made("study.results.json") == figures);
    pictures.write("ours", "one.png", "40x30 8");
    CHECK_THROWS_WITH(pictures.run_stage(options, run), Contains("p1.json: answers of another study"));
    options.set("key", key_file.string());
    CHECK_THROWS_WITH(pictures.run_stage(options, run), Contains("both the key of a study and its pictures"));
    CHECK_THROWS_WITH(pictures.run_stage(Value::Map{{"key", key_file.string()}}, run), Contains("result files too"));
}

TEST_CASE("too few pairs are reported, and a canceled run stops")
{
    const Pictures pictures;
    testing::TestRun run;
    Value options = pictures.below();
    options.set("pairs_count", 7);
    pictures.run_stage(options, run);
    REQUIRE(run.messages.size() == 1);
    CHECK_THAT(run.messages[0], Contains("warning: only 3 pairs for 2 questions"));
    CHECK_THROWS_WITH(pictures.run_stage(Value::Map{}, run), Contains("two methods or more, found none"));
    options.set("path", "study.htm");
    CHECK_THROWS_WITH(pictures.run_stage(options, run), Contains("ending in .html"));
    run.cancel_after(2);
    CHECK_THROWS_AS(pictures.run_stage(pictures.below(), run), Canceled);
}
