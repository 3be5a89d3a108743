/* SPDX-License-Identifier: Apache-2.0 */
int stfAbsent(void);
int stfDependent(void) { return stfAbsent(); }
