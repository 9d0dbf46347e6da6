#pragma once

#include <dn/distributions.h>  // IWYU pragma: export
