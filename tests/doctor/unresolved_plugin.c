/* SPDX-License-Identifier: Apache-2.0 */
/* A method of a class of an OpenUSD that is not there: pxrInternal_v0_99__pxrReserved__::HdRenderDelegate::Commit(). */
void _ZN32pxrInternal_v0_99__pxrReserved__16HdRenderDelegate6CommitEv(void);
void stfUnresolved(void) { _ZN32pxrInternal_v0_99__pxrReserved__16HdRenderDelegate6CommitEv(); }
