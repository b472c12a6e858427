// Needs a function that nobody has.
extern "C" int fresco_function_that_nobody_has();
extern "C" __attribute__((visibility("default"))) int answer();

int answer()
{
    return fresco_function_that_nobody_has();
}
