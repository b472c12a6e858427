#pragma once

#include "study.h"

/// Two views by the methods a and b, one more by b and c; two questions. Numbers as they stand here.
inline study::Study small_study()
{
    study::Study study;
    study.id = "0123456789abcdef0123456789abcdef";
    study.questions = {"Sharper?", "Brighter?"};
    study.pictures = {{"b", "one"}, {"a", "two"}, {"a", "one"}, {"b", "two"}, {"c", "three"}, {"b", "three"}};
    study.pairs_count = 6;
    return study;
}
