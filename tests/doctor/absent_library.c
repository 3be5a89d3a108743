/* SPDX-License-Identifier: Apache-2.0 */
int stfAbsent(void) { return 1; }
