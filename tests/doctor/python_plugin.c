/* SPDX-License-Identifier: Apache-2.0 */
extern void* PyExc_ValueError;
void* stfPythonsError(void) { return &PyExc_ValueError; }
