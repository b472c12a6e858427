// Writes over the host's channel, as a library does that takes descriptor 3 to be its own
#include <fresco/stage.h>
#include <unistd.h>

namespace
{
class Bad final : public fresco::Stage
{
  public:
    Bad()
    {
        constexpr char text[] = "cache opened\n[1]\n{\"step\": 7}\n";
        if (write(3, text, sizeof text - 1) < 0)
            throw fresco::Error("there is no descriptor 3");
    }
    void run(fresco::RunContext&) override {}
};
FRESCO_STAGE("bad.channel", Bad, "Writes over the host's channel")
}  // namespace
