#include "stability.h"

void suite_stability_watertight(void) {}
