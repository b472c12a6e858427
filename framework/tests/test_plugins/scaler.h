#pragma once

#include <fresco/component.h>

/// A contract of the test plugin's own.
class Scaler : public fresco::Component
{
  public:
    static constexpr std::string_view component_kind = "scaler";
    ~Scaler() override;
    virtual double scaled(double value) const = 0;
};
