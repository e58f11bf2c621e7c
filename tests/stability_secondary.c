#include "stability.h"

void suite_stability_secondary(void) {}
