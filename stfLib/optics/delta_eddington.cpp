// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/delta_eddington.h"

#include "stfLib/base/error.h"

namespace stf {

const char* name(TransportForm form) {
    return form == TransportForm::DE1 ? "dE1" : "classic";
}

TransportForm parseTransportForm(const std::string& text) {
    for (TransportForm form : {TransportForm::DE1, TransportForm::Classic}) {
        if (text == name(form)) {
            return form;
        }
    }
    throw Error("transport form '" + text + "' is not known; the known ones are dE1 and classic");
}

} // namespace stf
