// SPDX-License-Identifier: Apache-2.0
#ifndef RSH_RSH_H
#define RSH_RSH_H
#endif
