// A stage that takes its value from a library of its own.
#include <fresco/files.h>
#include <fresco/stage.h>

double side_value();

namespace
{

class Sided final : public fresco::Stage
{
    fresco::Output<fresco::Table> table{this, "table", "The number"};

    void run(fresco::RunContext&) override
    {
        fresco::Table made;
        made.columns = {"value"};
        made.rows = {{side_value()}};
        table = std::move(made);
    }
};

}  // namespace

FRESCO_STAGE("test.sided", Sided, "A number from beside")
