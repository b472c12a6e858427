#include "program.h"

#include "worker/stage_run.h"
#include <fresco/files_io.h>

using fresco::Value;
using fresco::host::without_folders;

namespace
{

const char* const diamond = R"(version: 1
stages:
  source: {type: test.source, value: 3, folder: scan, file: extra, log: log}
  other:  {type: test.source, value: 4, log: log}
  scale:  {type: test.scale, input: source, log: log}
  add:    {type: test.add, input: {left: scale, right: source}, log: log}
  sum:    {type: test.add, input: {left: add, right: other}, log: log}
  told:   {type: test.told, input: sum, log: log}
)";

void write_diamond(const Workplace& place)
{
    place.write("scan/a", "12");
    place.write("extra", "123");
    place.write("room.yaml", diamond);
}

std::string told(Workplace& place, const std::vector<std::string>& more = {})
{
    std::vector<std::string> arguments{"run", "room.yaml", "--cores", "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Finished finished = place.run(arguments);
    INFO(finished.err);
    REQUIRE(finished.code == 0);
    return place.read("out/origin.json");
}

}  // namespace

TEST_CASE("Of an absolute path the name of what it leads to is kept, wherever it stands")
{
    for (const auto& [text, expected] : std::map<std::string, std::string>{{"/home/ann/scan", "scan"},
                                                                           {"/home/ann lee/my scan", "my scan"},
                                                                           {"/home/ann/scan/", "scan/"},
                                                                           {"~/scan", "scan"},
                                                                           {"~ann/scan", "scan"},
                                                                           {"--in=/home/ann lee/x.png", "--in=x.png"},
                                                                           {"a /b/c --out /d/e", "a e"},
                                                                           {"file:///home/ann/x", "file:x"},
                                                                           {"input:data/scan", "input:data/scan"},
                                                                           {"https://host/page", "https://host/page"},
                                                                           {"1/2", "1/2"},
                                                                           {"/", ""},
                                                                           {"", ""}})
    {
        INFO(text);
        CHECK(without_folders(text) == expected);
    }
}

TEST_CASE("A stage learns how its result comes about, from options to figures, without paths")
{
    Workplace place;
    write_diamond(place);
    const std::string text = told(place);
    CHECK_FALSE(contains(text, place.root().string()));
    CHECK_FALSE(contains(text, "log"));
    const Value origin = fresco::parse_json(text);
    CHECK(origin.at("versions").at("Testlib") == Value("1.2.3"));
    CHECK(origin.at("versions").find("fresco") != nullptr);

    const Value::List& stages = origin.at("stages").as_list();
    std::vector<std::string> names;
    for (const Value& stage : stages)
        names.push_back(stage.at("stage").as_string());
    REQUIRE(names ==
            std::vector<std::string>{"test.source", "test.scale", "test.add", "test.source 2", "test.add 2", "test.told"});
    const Value& options = stages[0].at("options");
    CHECK(options.at("value") == Value(3.0));
    CHECK(options.at("folder") == Value("scan"));
    CHECK(options.at("file") == Value(Value::Map{{"file", "extra"}, {"xxh128", fresco::content_hash("123")}}));
    CHECK(stages[1].at("options").at("first") == Value(Value::Map{{"type", "test.factor"}, {"factor", 2.0}}));
    CHECK(stages[2].at("inputs") == Value(Value::Map{{"left", "test.scale"}, {"right", "test.source"}}));
    CHECK(stages[4].at("inputs") == Value(Value::Map{{"left", "test.add"}, {"right", "test.source 2"}}));
    CHECK(stages[0].at("figures") == Value(Value::Map{{"threads", 1}}));
    CHECK(stages[5].find("figures") == nullptr);
}

TEST_CASE("What a stage learns of its origin does not depend on what the store still holds, nor on where it lies")
{
    Workplace place;
    write_diamond(place);
    const std::string text = told(place);
    // Only the result that the stage reads stays.
    for (const auto& entry : fs::directory_iterator(place.file(".fresco/objects")))
        if (fresco::parse_json(fresco::read_text_file(entry.path() / "manifest.json")).at("stage") != Value("sum"))
            fs::remove_all(entry.path());
    place.clear_log();
    CHECK(told(place) == text);
    CHECK(place.log() == std::vector<std::string>{"told"});

    Workplace elsewhere;
    write_diamond(elsewhere);
    CHECK(told(elsewhere) == text);
}

TEST_CASE("Times and long lists are no part of an origin")
{
    const Value reported = Value::Map{{"charts", 427},
                                      {"seconds_per_step", 0.4},
                                      {"wait_s", 2},
                                      {"mesh", "/home/ann/mesh.ply"},
                                      {"up", Value::List{0, 0, 1}},
                                      {"mean", Value()},
                                      {"judged", Value::Map{{"least", 150}, {"names", Value::List{1, 2, 3, 4, 5}}}},
                                      {"table", Value::Map{{"rows", Value::List{Value::List{1}}}}}};
    const Value origin = fresco::host::with_figures(Value::List{Value::Map{{"type", "a"}}}, reported);
    CHECK(origin.as_list()[0].at("figures") ==
          Value(Value::Map{
              {"charts", 427}, {"mesh", "mesh.ply"}, {"up", Value::List{0, 0, 1}}, {"judged", Value::Map{{"least", 150}}}}));
}
