#include <fresco/error.h>

namespace fresco
{

Error::~Error() = default;
MissingInput::~MissingInput() = default;

Canceled::Canceled() : std::runtime_error("The run was interrupted.") {}
Canceled::~Canceled() = default;

}  // namespace fresco
