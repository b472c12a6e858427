/// Function that a plugin needs from the library beside it.
double side_value()
{
    return 7;
}
