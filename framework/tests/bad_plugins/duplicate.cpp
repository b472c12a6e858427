// A type that another plugin has too.
#include <fresco/stage.h>

namespace
{
class Duplicate final : public fresco::Stage
{
    void run(fresco::RunContext&) override {}
};
FRESCO_STAGE("test.source", Duplicate, "Not the one you want")
FRESCO_STAGE("test.only_here", Duplicate, "The other type of this library can be used")
}  // namespace
