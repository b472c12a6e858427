#include "program.h"
#include "report/sweep_page.h"

#include "report/sweep_summary.h"
#include <fresco/html.h>

using namespace fresco::host;

namespace
{

SweepCell cell(const std::vector<std::string>& values)
{
    SweepCell result;
    for (const std::string& value : values)
        result.name += (result.name.empty() ? "" : ",") + value;
    result.values = values;
    result.state = "done";
    return result;
}

std::size_t count(const std::string& text, const std::string& part)
{
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++found;
    return found;
}

std::string as_uri(const std::string& text)
{
    return fresco::data_uri("image/jpeg", std::as_bytes(std::span(text)));
}

const char* const sweep = R"(version: 1
vars: {n: }
matrix: {n: [110, 120, 130]}
stages:
  one:  {type: test.source, value: "${n}"}
  view: {type: test.sink, input: one, path: view.png}
)";

}  // namespace

TEST_CASE("the page of a matrix is a table of its last two axes, one for each value of those before")
{
    SweepPage page{"a <b> & c.yaml", {"x", "y", "z"}, {}, ""};
    for (const char* x : {"x=1", "b"})
        for (const char* y : {"c", "d"})
            for (const char* z : {"e", "f", "g"})
                page.cells.push_back(cell({x, y, z}));
    page.cells[0].pictures = {{"a b/50%.png", "data:image/jpeg;base64,AAAA"}, {"é.png", ""}};
    page.cells[0].seconds = 65;
    page.cells[0].report = "x=1,c,e/report.html";
    page.cells[4].state = "failed";
    page.cells[4].error = "<no>";
    for (int i = 0; i < 70; ++i)
        page.cells[5].files.push_back("f/" + std::to_string(i));
    const std::string html = sweep_html(page);
    CHECK(contains(html, "<title>a &lt;b&gt; &amp; c.yaml</title>"));
    CHECK(contains(html, "12 combinations · 11 done · 1 failed"));
    CHECK(count(html, "<table>") == 2);
    CHECK(contains(html, "<h2>x=1</h2>"));
    CHECK(contains(html, "<h2>x: b</h2>"));
    CHECK(count(html, "<tr><th>c</th>") == 2);
    CHECK(count(html, "<th>y \\ z</th><th>e</th><th>f</th><th>g</th></tr>") == 2);
    CHECK(count(html, "<td>") == 12);
    CHECK(contains(html, "<a href=\"a%20b/50%25.png\"><img loading=\"lazy\" alt=\"a b/50%.png\" "
                         "src=\"data:image/jpeg;base64,AAAA\"></a>"));
    CHECK(contains(html, "src=\"%C3%A9.png\""));
    CHECK(contains(html, "done</span> · 1:05 min · <a href=\"x=1,c,e/report.html\">report</a>"));
    CHECK(contains(html, "<span class=\"state failed\">failed</span></div><pre>&lt;no&gt;</pre>"));
    CHECK(contains(html, "<summary>70 files</summary>"));
    CHECK(contains(html, "<li>and 10 more</li>"));
    CHECK(count(html, "no picture") == 11);
    CHECK(count(html, "<script") == 0);
    CHECK(count(html, "http") == 0);

    page.axes = {"x"};
    page.cells = {cell({"a"}), cell({"b"})};
    page.note = "why";
    const std::string cards = sweep_html(page);
    CHECK(count(cards, "<article>") == 2);
    CHECK(count(cards, "<table>") == 0);
    CHECK(contains(cards, "<p class=\"about\">why</p>"));
}

TEST_CASE("pictures of a combination: of the last stage that made some for it alone, spread evenly")
{
    Pipeline pipeline;
    for (const auto& [own_name, place] : {std::pair{"views", "a"}, {"last", ""}, {"text", "a"}, {"extra", "a"}})
    {
        PipelineStage stage;
        stage.name = stage.own_name = own_name;
        stage.place = place;
        pipeline.stages.push_back(stage);
    }
    const Combination combination{"a", {"a"}, {0, 1, 2, 3}};
    RunSummary summary;
    CombinationOutcome outcome;
    outcome.combination = &combination;
    const auto add = [&](const char* stage, const std::string& name)
    {
        outcome.files.push_back(summary.files.size());
        summary.files.push_back({stage, "/out/" + name, true});
    };
    for (int i = 0; i < 10; ++i)
        add("views", std::to_string(i) + ".png");
    add("last", "last.jpg");
    add("text", "a.txt");
    using Numbers = std::vector<std::size_t>;
    CHECK(pictures_of(pipeline, summary, outcome, "", 1) == Numbers{5});
    CHECK(pictures_of(pipeline, summary, outcome, "", 3) == Numbers{1, 5, 8});
    CHECK(pictures_of(pipeline, summary, outcome, "", 20).size() == 10);
    CHECK(pictures_of(pipeline, summary, outcome, "last", 3) == Numbers{10});
    CHECK(pictures_of(pipeline, summary, outcome, "text", 3).empty());
    add("extra", "b.jpeg");
    CHECK(pictures_of(pipeline, summary, outcome, "", 3) == Numbers{12});
    outcome.files.clear();
    CHECK(pictures_of(pipeline, summary, outcome, "", 3).empty());
}

TEST_CASE("a sweep ends with a page of small pictures, which stays where nothing is new")
{
    Workplace place({"good", "pictures"});
    place.write("sweep.yaml", sweep);
    const Finished first = place.run({"run", "sweep.yaml"});
    CHECK(first.code == 0);
    CHECK(contains(first.out, "out/sweep.html"));
    const std::string html = place.read("out/sweep.html");
    for (const char* text : {"480x240 of 110", "480x240 of 120", "480x240 of 130"})
        CHECK(count(html, as_uri(text)) == 1);
    CHECK(contains(html, "<a href=\"n=120/view.png\">"));
    REQUIRE(place.run({"run", "sweep.yaml"}).code == 0);
    CHECK(place.read("out/sweep.html") == html);
    REQUIRE(place.run({"run", "sweep.yaml", "--set", "n=[110, 140]"}).code == 0);
    CHECK(count(place.read("out/sweep.html"), as_uri("480x240 of 140")) == 1);
    CHECK(fs::is_empty(place.file(".fresco/tmp")));
    CHECK(contains(place.run({"run", "sweep.yaml", "--thumbnails", "veiw"}).err,
                   "--thumbnails veiw: error: unknown stage 'veiw' (did you mean 'view'?)"));
    REQUIRE(place.run({"run", "sweep.yaml", "--thumbnails", "one"}).code == 0);
    CHECK(count(place.read("out/sweep.html"), "no picture") == 3);
}

TEST_CASE("while a page is made the store is in use")
{
    Workplace place({"good", "pictures"});
    place.write("sweep.yaml", sweep);
    const auto run = place.start({"run", "sweep.yaml", "--no-report", "--set", "n=[15, 110]"});
    Workplace::wait_until([&] { return fs::exists(place.file("out/open")); });
    const fresco::host::Store store(place.file(".fresco"));
    CHECK_FALSE(fresco::host::store_lock(store).try_exclusive());
    fs::remove(place.file("out/open"));
    CHECK(run->wait().code == 0);
    CHECK(count(place.read("out/sweep.html"), as_uri("480x240 of 15")) == 1);
    CHECK(fresco::host::store_lock(store).try_exclusive());
}

TEST_CASE("where a picture cannot be opened the page is there all the same")
{
    const bool plugin = GENERATE(true, false);
    Workplace place(plugin ? std::vector<std::string>{"good", "pictures"} : std::vector<std::string>{"good"});
    place.write("sweep.yaml", sweep);
    // The reader crashes, or there is none.
    const Finished crash = place.run({"run", "sweep.yaml", "--set", "n=[13, 110]"});
    CHECK(crash.code == 0);
    CHECK(contains(crash.err, plugin ? "ended by Segmentation fault" : "no plugin reads and writes pictures"));
    CHECK(contains(place.read("out/sweep.html"), "src=\"n=110/view.png\""));
    if (!plugin)
        return;
    // One picture is broken, the other is not.
    REQUIRE(place.run({"run", "sweep.yaml", "--set", "n=[14, 110]"}).code == 0);
    const std::string html = place.read("out/sweep.html");
    CHECK(contains(html, "view.png: is cut"));
    CHECK(contains(html, "src=\"n=14/view.png\""));
    CHECK(contains(html, as_uri("480x240 of 110")));
}
