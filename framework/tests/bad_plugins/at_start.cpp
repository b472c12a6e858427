// Does at its start what no plugin may; BAD_WAY says what.
#include <fresco/mesh.h>
#include <fresco/stage.h>

#include <cstdlib>
#include <fstream>
#include <string_view>
#include <unistd.h>

namespace
{

constexpr std::string_view way = BAD_WAY;

class Bad final : public fresco::Stage
{
  public:
    Bad()
    {
        if (way == "throws")
            throw fresco::Error("no license for today");
        // As a library does that takes descriptor 3 to be its own.
        constexpr std::string_view text = "cache opened\n[1]\n{\"step\": 7}\n";
        if (way == "channel" && write(3, text.data(), text.size()) < 0)
            throw fresco::Error("there is no descriptor 3");
        if (way == "hangs")
            hang();
    }
    void run(fresco::RunContext&) override {}
    fresco::Cost cost() const override
    {
        if (way != "cost")
            return {};
        return {.makes = {{fresco::count::faces, {.at_most = "max_facez"}}}};
    }

  private:
    /// BAD_LOG is a file that gets a line each time.
    static void hang()
    {
        if (const char* log = std::getenv("BAD_LOG"))
            std::ofstream(log, std::ios::app) << "asked" << std::endl;
        for (volatile bool on = true; on;)
            continue;
    }
};
FRESCO_STAGE("bad." BAD_WAY, Bad, "Does at its start what no plugin may")

}  // namespace
