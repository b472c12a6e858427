#pragma once

#include <stdexcept>
#include <string>

/// \file What plugins and the host throw. Everything else that is thrown is reported as a bug.

namespace fresco
{

/// An error meant for the person who runs the pipeline: the text names the file (and line or offset), what was expected and
/// what to do. Stages throw it; the host adds the stage's name and its place in the pipeline file.
class Error : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
    ~Error() override;
};

/// An input file, folder or weights file is missing or cannot be read: the program ends with exit code 3.
class MissingInput : public Error
{
  public:
    using Error::Error;
    ~MissingInput() override;
};

/// The run was asked to stop: the program ends with exit code 75 and the next run goes on.
class Canceled : public std::runtime_error
{
  public:
    Canceled();
    ~Canceled() override;
};

}  // namespace fresco
