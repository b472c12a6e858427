#include <fresco/error.h>

namespace fresco
{

Error::~Error() = default;
MissingInput::~MissingInput() = default;

Cancelled::Cancelled() : std::runtime_error("The run was interrupted.") {}
Cancelled::~Cancelled() = default;

}  // namespace fresco
