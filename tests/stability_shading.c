#include "stability.h"

void suite_stability_shading(void) {}
