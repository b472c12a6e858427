#include "catch.h"
#include "worker/worker_context.h"

#include <fresco/testing.h>

#include <fstream>

using namespace fresco;
using namespace fresco::host;

TEST_CASE("curves are kept within bounds, go back with their stage and survive a killed run")
{
    const auto loss = [](double value) { return Value(Value::Map{{"loss", value}}); };
    MetricCurves curves;
    CHECK_FALSE(curves.add(0, Value::Map{}));
    CHECK(curves.to_value("steps").is_null());
    for (int step = 1; step <= 10'000; ++step)
        curves.add(step, loss(step));
    CHECK(curves.points().size() <= MetricCurves::most_points);
    CHECK(curves.points().size() > MetricCurves::most_points / 3);
    CHECK(curves.points().front().done == 1);
    CHECK(curves.points().back().done > 9900);
    const double step = curves.points()[1].done - curves.points()[0].done;
    for (std::size_t i = 1; i < curves.points().size(); ++i)
        CHECK(curves.points()[i].done - curves.points()[i - 1].done == step);
    MetricCurves back;
    for (const int done : {1, 2, 3, 4, 2})
        back.add(done, loss(done * 10));
    CHECK(back.to_value("steps").at("done") == Value::List{1.0, 2.0});

    const testing::TemporaryFolder folder;
    const auto file = folder.path() / "curves";
    std::string damaged = MetricCurves::line(2, loss(30));
    damaged.replace(damaged.find("30"), 2, "31");
    std::ofstream(file) << MetricCurves::line(1, loss(4)) << damaged << MetricCurves::line(2, loss(3))
                        << MetricCurves::line(3, Value::Map{{"loss", Value()}, {"other", 7}}) << R"({"done":4,"me)";
    MetricCurves taken;
    taken.load(file);
    taken.load(folder.path() / "nothing");
    CHECK(taken.to_value("steps") ==
          parse_json(R"({"unit":"steps","done":[1.0,2.0,3.0],"metrics":{"loss":[4.0,3.0,null],"other":[null,null,7]}})"));
}
