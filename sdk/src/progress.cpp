#include <fresco/progress.h>
#include <fresco/run_context.h>

namespace fresco
{

Progress::~Progress() = default;
void Progress::progress(double, double, std::string_view) {}
void Progress::check_canceled() const {}
int Progress::threads() const
{
    return 1;
}

RunContext::~RunContext() = default;

}  // namespace fresco
