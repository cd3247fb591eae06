#pragma once
#define TARGET_OS_IPHONE 1
