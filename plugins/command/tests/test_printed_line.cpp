#include "catch.h"
#include "printed_line.h"

using namespace fresco::command;

TEST_CASE("a program's lines to the host are distinguished from all others", "[command]")
{
    using Kind = SaidToHost::Kind;
    const auto progress = [](const char* line)
    {
        const auto said = said_to_host(line).value();
        CHECK(said.kind == Kind::progress);
        return std::tuple(said.done, said.total, said.text);
    };
    CHECK(progress("fresco: progress 0.25\r") == std::tuple(25, 100, "%"));
    CHECK(progress("fresco: progress 12/100  frames drawn") == std::tuple(12, 100, "frames drawn"));
    CHECK(said_to_host("fresco: progress 1/2 \x1b[2Jmaps")->text == "maps");
    const auto metric = said_to_host("fresco: metric loss 1e-3");
    REQUIRE(metric);
    CHECK(metric->kind == Kind::metric);
    CHECK(metric->text == "loss");
    CHECK(metric->done == 1e-3);
    CHECK(said_to_host("fresco: warning too dark")->kind == Kind::warning);
    CHECK(said_to_host("fresco: message hello")->text == "hello");
    CHECK(said_to_host("fresco: report sizes [1, 2]")->json == "[1, 2]");
    for (const char* line :
         {"", "progress 0.5", "fresco:", "fresco: ", "fresco: progress", "fresco: progress 2", "fresco: progress -1/2",
          "fresco: progress 1/0", "fresco: progress nan", "fresco: progress 1/inf", "fresco: progress x/2", "fresco: metric loss",
          "fresco: metric loss low", "fresco: report name", "fresco: warning", "Fresco: message x"})
    {
        INFO(line);
        CHECK_FALSE(said_to_host(line));
    }
}

TEST_CASE("what a program prints is shown as a terminal would, and is always text", "[command]")
{
    CHECK(printable("10 %\r20 %\r") == "20 %");
    CHECK(printable("\x1b[31mred\x1b[0m \x1b(Bx") == "red Bx");
    CHECK(printable("a\tb\x01"
                    "c") == "a b c");
    CHECK(printable("gr\xc3\xbc\xc3\x9f \xf0\x9f\x8e\xa8") == "gr\xc3\xbc\xc3\x9f \xf0\x9f\x8e\xa8");
    CHECK(printable("\xff\xc3(\xed\xa0\x80\xe2\x82") == std::string(2, '?') + "(?????");
    CHECK(printable("a\xc2\x9b"
                    "31m\xc2\xa0\xc2") == "a 31m\xc2\xa0?");
    CHECK(printable("\x1b") == "");
    CHECK(printable("\x1b[") == "");
}
